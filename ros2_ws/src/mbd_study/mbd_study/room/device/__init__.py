"""Films of the room from a camera and a microphone of this machine, by FFmpeg's own devices in PyAV's wheel."""
