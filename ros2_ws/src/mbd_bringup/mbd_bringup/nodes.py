"""Which nodes make up a session, written once: the launch file and the demo start what this states."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from pathlib import Path

from mbd_bag.spool.parameters import WRITERS
from mbd_cell.parameters import CELL
from mbd_console.parameters import CONSOLE
from mbd_console.study.form_plan import form_plan
from mbd_mapping.parameters import MAPPING
from mbd_model.errors import MbdError
from mbd_perception.parameters import PERCEPTION

from mbd_bringup.parameter_file import own_file
from mbd_bringup.robot_settings import Parameter, camera_settings, robot_settings, unrecorded

STRATEGIES = ("mbd", "evidence")
GRASPS = tuple(CELL["grasp"].choices)
# Parameter files: where the camera stands, and where objects can be.
CELL_CAMERA, CELL_WORKSPACE = ("mbd_cell", "camera.yaml"), ("mbd_cell", "workspace.yaml")
JACO2_CAMERA, JACO2_WORKSPACE = ("mbd_bringup", "jaco2_camera.yaml"), ("mbd_bringup", "jaco2_workspace.yaml")
HIGHEST_SEED, HIGHEST_SPEED, HIGHEST_PORT = 2**31 - 1, 1000.0, 65535
PORT = 8080  # of the console, when no other is given
# A scripted operator may miss a word, so the teacher says it again soon; a person hears it, and takes his time.
PERSONS_TIME = 20.0  # [s]
# A simulated camera renders as fast as a busy machine lets it; still less than the dialogue waits for an answer.
RENDERING_PATIENCE = 25.0  # [s]


@dataclass(frozen=True)
class SessionOptions:
    """What a session is started with.

    Attributes:
        session: its name; also the name of its bag.
        folder: where its bag, kept state and logs go.
        task: name of the task ("sorting", "stacking", ...).
        seed: of every random choice in the simulated cell.
        strategy: of the mapping ("evidence", or "mbd", the paper's rule).
        threshold: confidence from which the robot goes on alone; None takes the strategy's own (mbd: the paper's 0.02).
        simulated: True starts the cell with its scripted teacher; False expects a real robot and camera.
        speed: of simulated time against the wall clock; 0 is as fast as this machine can.
        participant: who teaches, for the bag.
        execute: the robot executes the task on the target objects; else it states what it would do.
        scripted_wizard: in simulation, a scripted operator answers; else a person does, by topics or console.
        console: start the operator's web page.
        markers: publish the session as markers for RViz and Foxglove.
        resume: go on in the bag of a session that was interrupted.
        run: names this start of the session, so that a recorder that is started again within it goes on in its bag.
        wrong_step: index of the step about which the scripted wizard answers wrongly once; -1: none.
        robot: name or file of the robot's profile; "" for the suite's own topics. In simulation the cell plays it.
        camera: name or file of the camera's profile, alike.
        port: of the operator's web page, TCP.
        forms: of the study, NAME or NAME@phase each, as the console takes them.
        language: of the console's pages: en, de.
        plan: what the bag is to state of the study's plan, ``name=value`` each.
        grasp: what keeps an object in the simulated hand: weld, for tests and trials of the nodes, or friction
            (docs/cell.md).
        camera_file: parameter file of where the camera stands, as `calibrate` writes it; "" for the one that is here.
        workspace_file: parameter file of where objects can be, alike.
        lab_prior: parameter file of what earlier sessions taught the mapping, as `lab_prior` writes it; "" for none.

    Raises:
        MbdError: a value that no node would take; the text begins with its name.
    """

    session: str
    folder: Path
    task: str = "sorting"
    seed: int = 1
    strategy: str = "evidence"
    threshold: float | None = None
    simulated: bool = True
    speed: float = 1.0
    participant: str = ""
    execute: bool = False
    scripted_wizard: bool = True
    console: bool = False
    markers: bool = False
    resume: bool = False
    run: str = field(default_factory=lambda: secrets.token_hex(8), compare=False)
    wrong_step: int = -1
    robot: str = ""
    camera: str = ""
    port: int = PORT
    forms: tuple[str, ...] = ()
    language: str = "en"
    plan: tuple[str, ...] = ()
    grasp: str = "weld"
    camera_file: str = ""
    workspace_file: str = ""
    lab_prior: str = ""

    def __post_init__(self) -> None:
        """Validate once, before any process is started."""
        if not self.session or "/" in self.session:
            raise MbdError(f"session '{self.session}' names a folder: it must not be empty nor hold a slash")
        if not 0 <= self.seed <= HIGHEST_SEED:
            raise MbdError(f"seed {self.seed} is not in 0..{HIGHEST_SEED}")
        if self.strategy not in STRATEGIES:
            raise MbdError(f"strategy '{self.strategy}' is none of {', '.join(STRATEGIES)}")
        if self.threshold is not None and not 0.0 <= self.threshold <= 1.0:
            raise MbdError(f"threshold {self.threshold:g} is not in 0..1: it is a confidence (the paper's is 0.02)")
        if not 0.0 <= self.speed <= HIGHEST_SPEED:
            raise MbdError(f"speed {self.speed:g} is not in 0..{HIGHEST_SPEED:g} (0: as fast as possible)")
        if self.grasp not in GRASPS:
            raise MbdError(f"grasp '{self.grasp}' is none of {', '.join(GRASPS)}")
        if not 1 <= self.port <= HIGHEST_PORT:
            raise MbdError(f"port {self.port} is not in 1..{HIGHEST_PORT}; the console's own is {PORT}")
        if self.language not in CONSOLE["language"].choices:
            raise MbdError(f"language '{self.language}' is none of {', '.join(CONSOLE['language'].choices)}")
        form_plan(self.forms)
        # A profile that cannot be used ends the session before it begins.
        robot_settings(self.robot)
        camera_settings(self.camera)
        session_files(self)

    @property
    def bag(self) -> Path:
        """Folder of the session's bag."""
        return self.folder / "bag"

    @property
    def spool(self) -> Path:
        """Folder in which is kept what the recorder may miss."""
        return self.folder / "spool"

    @property
    def led_by_person(self) -> bool:
        """Whether a person is the operator, by console or topics."""
        return not (self.simulated and self.scripted_wizard)

    @property
    def state(self) -> Path:
        """Folder in which the nodes keep what must survive their restart."""
        return self.folder / "state"


@dataclass(frozen=True)
class NodeSpec:
    """One process: ``ros2 run package executable`` with these parameters.

    Attributes:
        package, executable: as ``ros2 run`` takes them.
        parameters: by name.
        config: (package, file below its config folder) of each parameter file that comes first; package "" with a
            path for a file of a person's own.
        shared_memory: it gives or takes images that would get lost otherwise (see ``transport``).
    """

    package: str
    executable: str
    parameters: dict[str, Parameter] = field(default_factory=dict)
    config: tuple[tuple[str, str], ...] = ()
    shared_memory: bool = False


@dataclass(frozen=True)
class SessionFiles:
    """Parameter files as ``NodeSpec.config`` has them: one of the camera, one of the workspace, and maybe a prior."""

    camera: tuple[tuple[str, str], ...]
    workspace: tuple[tuple[str, str], ...]
    prior: tuple[tuple[str, str], ...]


def session_files(options: SessionOptions) -> SessionFiles:
    """The parameter files that these options ask for; raises MbdError for one that no node would take."""
    camera = own_file("camera_file", options.camera_file, (PERCEPTION, CONSOLE) if options.console else (PERCEPTION,))
    workspace = own_file("workspace_file", options.workspace_file, (PERCEPTION,))
    return SessionFiles(
        camera or (CELL_CAMERA if options.simulated else JACO2_CAMERA,),
        workspace or (CELL_WORKSPACE if options.simulated else JACO2_WORKSPACE,),
        own_file("lab_prior", options.lab_prior, (MAPPING,)),
    )


def session_nodes(options: SessionOptions) -> tuple[NodeSpec, ...]:
    """The nodes of one session in the order in which they are best started (the recorder first, the actors last)."""
    clock: dict[str, Parameter] = {"use_sim_time": options.simulated}
    kept: dict[str, Parameter] = {"state_dir": str(options.state)}
    rendered: dict[str, Parameter] = {"timeout": RENDERING_PATIENCE} if options.simulated else {}
    robot, eyes = robot_settings(options.robot), camera_settings(options.camera)
    shared = not (options.simulated and eyes.reliable)
    threshold: dict[str, Parameter] = {} if options.threshold is None else {"threshold": options.threshold}
    files = session_files(options)
    nodes = [
        NodeSpec(
            "mbd_bag",
            "recorder",
            {
                **clock,
                "bag": str(options.bag),
                "session": options.session,
                "participant": options.participant,
                "task": options.task,
                "seed": options.seed,
                "resume": options.resume,
                "run": options.run,
                "end_with_session": True,
                "spool": str(options.spool),
                **({"plan": list(options.plan)} if options.plan else {}),
                **unrecorded(robot, eyes),
            },
            shared_memory=shared,
        ),
        *(
            NodeSpec(
                "mbd_bag",
                writer,
                {**clock, "folder": str(options.spool), "run": options.run, **unrecorded(robot, eyes)},
            )
            for writer in WRITERS
        ),
        NodeSpec(
            "mbd_mapping",
            "mapping",
            {**clock, "strategy": options.strategy, **threshold},
            config=files.prior,
        ),
        NodeSpec("mbd_demonstration", "demonstration", {**clock, **kept, **robot.demonstration}),
        NodeSpec(
            "mbd_perception",
            "perception",
            {**clock, **kept, **rendered, **robot.perception, **eyes.perception},
            config=(*files.camera, *files.workspace),
            shared_memory=shared,
        ),
        NodeSpec(
            "mbd_interaction",
            "interaction",
            {**clock, **kept, "session": options.session, "execute": options.execute},
        ),
    ]
    if options.execute:
        nodes.append(NodeSpec("mbd_execution", "execution", {**clock, **kept, **robot.execution}))
    if options.robot:
        nodes.append(NodeSpec("mbd_robot", "robot", {**clock, "robot": options.robot}))
    if eyes.repeated:
        nodes.append(NodeSpec("mbd_robot", "camera", {**clock, "camera": options.camera}, shared_memory=shared))
    if options.console:
        pages: dict[str, Parameter] = {"port": options.port, "language": options.language}
        pages["room_dir"] = str(options.folder)
        if options.forms:
            pages["forms"] = list(options.forms)
        nodes.append(
            NodeSpec(
                "mbd_console",
                "console",
                {**clock, **kept, **pages},
                config=files.camera,
                shared_memory=shared,
            )
        )
    if options.markers:
        nodes.append(NodeSpec("mbd_bringup", "markers", {**clock}))
    if options.simulated and options.scripted_wizard:
        nodes.append(NodeSpec("mbd_cell", "wizard", {**clock, "wrong_step": options.wrong_step}))
    if options.simulated:
        acted: dict[str, Parameter] = {
            "task": options.task, "seed": options.seed, "speed": options.speed, "grasp": options.grasp,
        }  # fmt: skip
        if options.led_by_person:
            acted["reminder"] = PERSONS_TIME
        if options.robot:
            acted["robot"] = options.robot
        if options.camera:
            acted["camera"] = options.camera
        nodes.append(NodeSpec("mbd_cell", "cell", acted, shared_memory=shared))
    return tuple(nodes)
