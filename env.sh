# Source this (bash or zsh) for a shell with the environment and the overlay: `source env.sh`, then `./mbd run PKG EXE`
# or, on a normal ROS 2 install, `ros2 run PKG EXE`.
if [ -n "${BASH_SOURCE:-}" ]; then _mbd_root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P); else _mbd_root=$(cd "$(dirname "$0")" && pwd -P); fi
_mbd_not=
if [ ! -f "$_mbd_root/ros2_ws/install/setup.bash" ]; then
  _mbd_not="not built yet"
elif [ -f "$_mbd_root/.venv/.mbd-kind" ]; then
  case "$(cat "$_mbd_root/.venv/.mbd-kind")" in *" $_mbd_root") ;; *) _mbd_not="built in another folder and then moved to this one" ;; esac
fi
if [ -n "$_mbd_not" ]; then
  echo "env.sh: $_mbd_not; run: make build" >&2
  unset _mbd_root _mbd_not
  return 1
else
  . "$_mbd_root/tools/ros-kind"
  # A guard inherited from another environment would keep the wheels' libraries off the path.
  unset _ROS_WHEELS_BOOTSTRAP_COMPLETE
  case ":$PATH:" in *":$_mbd_root/.venv/bin:"*) ;; *) export PATH="$_mbd_root/.venv/bin:$PATH" ;; esac
  export VIRTUAL_ENV="$_mbd_root/.venv"
  if [ "$MBD_ROS" = wheels ]; then . "$_mbd_root/.venv/local_setup.sh"; fi
  if [ -n "${ZSH_VERSION:-}" ]; then . "$_mbd_root/ros2_ws/install/setup.zsh"; else . "$_mbd_root/ros2_ws/install/setup.bash"; fi
  # A session is a dozen processes: whatever one has compiled, the others and the next session need not compile again.
  unset PYTHONDONTWRITEBYTECODE
  # Large clouds and images need the shared-memory profile; nothing leaves this machine unless asked to.
  export FASTRTPS_DEFAULT_PROFILES_FILE="${FASTRTPS_DEFAULT_PROFILES_FILE:-$_mbd_root/ros2_ws/src/mbd_bringup/config/fastdds_profile.xml}"
  # Only the pytest plugins that are asked for: those of a normal ROS 2 install are for launch tests and an older pytest.
  export PYTEST_DISABLE_PLUGIN_AUTOLOAD=1
  export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}"
fi
unset _mbd_root _mbd_not
