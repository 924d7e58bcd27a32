"""Quality of service by what a topic carries (DESIGN: latched facts, events, sensor streams)."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data

# A fact: whoever comes late still gets the last one.
LATCHED = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)

# An event: none may be lost, and none is repeated to latecomers.
EVENTS = QoSProfile(
    history=HistoryPolicy.KEEP_ALL,
    depth=0,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
)

# A stream: the newest matters, a lost one does not.
SENSOR = qos_profile_sensor_data

# Images of our own: too large to arrive whole where lost fragments are not sent again; the newest matters.
IMAGES = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=2,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
)

# A guided motion: offered as a stream, but a hole in it is a hole in the demonstration. Whoever reads it keeps what
# came while it was held up for seconds.
MOTION = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1000,
    reliability=ReliabilityPolicy.BEST_EFFORT,
    durability=DurabilityPolicy.VOLATILE,
)
