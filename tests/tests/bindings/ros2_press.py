"""Stand-ins of rclpy and of the messages that the ROS 2 node uses, and a press through that node. Prints position, force and torque
of every tick, then what the node says of a gap between stamps, of a clear, and of a pose in another frame."""
import runpy
import sys
from types import ModuleType, SimpleNamespace


class Checked:
    """Like a message of ROS: fields have fixed names and types."""

    def __init__(self):
        for name, kind in type(self).FIELDS.items():
            object.__setattr__(self, name, kind())

    def __setattr__(self, name, value):
        assert type(value) is type(self).FIELDS[name], (name, value)
        object.__setattr__(self, name, value)


def message(name, **fields):
    return type(name, (Checked,), {"FIELDS": fields})


Time = message("Time", sec=int, nanosec=int)
Header = message("Header", stamp=Time, frame_id=str)
Vector = message("Vector3", x=float, y=float, z=float)
Quaternion = message("Quaternion", x=float, y=float, z=float, w=float)
Pose = message("Pose", position=Vector, orientation=Quaternion)
PoseStamped = message("PoseStamped", header=Header, pose=Pose)
Wrench = message("Wrench", force=Vector, torque=Vector)
WrenchStamped = message("WrenchStamped", header=Header, wrench=Wrench)
Response = message("Trigger_Response", success=bool, message=str)
node = None
logged, published = [], []


class Node:
    def __init__(self, name):
        global node
        node, self.callbacks, self.qos = self, {}, None

    def declare_parameter(self, name, default):
        return SimpleNamespace(value=default)

    def get_logger(self):
        return SimpleNamespace(warning=logged.append, error=logged.append)

    def create_publisher(self, kind, topic, qos):
        assert (kind, topic) == (WrenchStamped, "wrench")
        return SimpleNamespace(publish=published.append)

    def create_subscription(self, kind, topic, callback, qos):
        assert (kind, topic) == (PoseStamped, "tip")
        self.callbacks[topic], self.qos = callback, qos
        return callback

    def create_service(self, kind, name, callback):
        self.callbacks[name] = callback

    def destroy_node(self):
        logged.append("destroyed")


def call(name):
    return node.callbacks[name](None, Response())


def tell(ms, z_m, frame_id="tissue", w=1.0):
    pose = PoseStamped()
    pose.header.stamp.sec, pose.header.stamp.nanosec = ms // 1000, ms % 1000 * 1_000_000
    pose.header.frame_id = frame_id
    p = pose.pose.position
    p.x, p.y, p.z = 1e-3, 2e-3, z_m
    pose.pose.orientation.w = w
    node.callbacks["tip"](pose)
    last = published[-1]
    assert last.header.stamp is pose.header.stamp and last.header.frame_id == "tissue"
    f, t = last.wrench.force, last.wrench.torque
    return [p.x, p.y, p.z, f.x, f.y, f.z, t.x, t.y, t.z]


def spin(spun):
    assert spun is node and node.qos == {"depth": 1, "reliability": "best effort"}
    assert call("arm").success
    for tick in range(2500):
        steps = 0 if tick < 700 else min(tick - 700, 2500 - tick)
        print(*(f"{number:.17g}" for number in tell(tick, 5e-3 - 1e-5 * steps)))
    del logged[:]
    print("gap", tell(2506, 5e-3)[5], tell(2512, 5e-3)[5], logged)
    for tick in range(200):
        tell(2513 + tick, 5e-3)
    call("clear")
    tell(2713, 5e-3)
    print("cleared", node.session.fault, call("arm").success)
    tell(2714, 5e-3, "map")
    print("frame", logged[1:])
    del logged[:]
    print("turn", tell(2715, 5e-3, w=0.0)[:3], tell(2716, 5e-3, w=0.0)[:3], len(logged), "orientation" in logged[0])
    raise KeyboardInterrupt


def module(name, **content):
    sys.modules[name] = made = ModuleType(name)
    made.__dict__.update(content)


module("rclpy", init=lambda: None, spin=spin, try_shutdown=lambda: logged.append("shut down"))
module("rclpy.node", Node=Node)
module("rclpy.executors", ExternalShutdownException=type("ExternalShutdownException", (Exception,), {}))
module("rclpy.qos", QoSProfile=dict, ReliabilityPolicy=SimpleNamespace(BEST_EFFORT="best effort"))
module("geometry_msgs", msg=None)
module("geometry_msgs.msg", PoseStamped=PoseStamped, WrenchStamped=WrenchStamped)
module("std_srvs", srv=None)
module("std_srvs.srv", Trigger=object)
runpy.run_path(sys.argv[1], run_name="__main__")
print("end", logged[-2:])
