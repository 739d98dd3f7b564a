"""A soft tissue as a ROS 2 node. UNTESTED WITH ROS: it runs against stand-ins of rclpy and its messages.

    python3 ros2_node.py --ros-args -p scene:=block -p device:=touch     # installed as the guide's page on ROS 2 says

Takes the pose of the probe's tip on `tip` (geometry_msgs/PoseStamped) and publishes the force on the device on `wrench`
(geometry_msgs/WrenchStamped, with the stamp of the pose). Each pose is one tick of 1 ms, so your driver publishes a thousand per
second; gaps between its stamps are late ticks, and two in a row are a fault. The services `arm`, `stop` and `clear` are
std_srvs/Trigger.

Poses are in the frame that the parameter `frame_id` names: metres; x to the operator, y to the operator's right, z up; the origin
is the site of the press. A pose in another frame counts as a failed sensor. Its orientation turns the probe; one that the session
refuses, such as all zeros, leaves the probe as it is. The torque is that about the tip, scaled like the force, and zero with a
package that has no `read_contact`. When poses end, so do wrenches: your controller has to let an old wrench go.
"""
import math

import rclpy
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

import palpate

TICK_NS = 1_000_000


def torque_nm(session, force_n):
    """Torque about the tip [N m], as much of the tissue's as the force on the device is of the tissue's force."""
    if not any(force_n) or not hasattr(session, "read_contact"):
        return (0.0, 0.0, 0.0)
    contact = session.read_contact()
    tissue_n = math.hypot(*(contact["normal_n"] + contact["friction_n"]))
    share = min(1.0, math.hypot(*force_n) / tissue_n) if tissue_n else 0.0
    return share * contact["torque_nm"]


class TissueNode(Node):
    def __init__(self):
        super().__init__("tissue")
        value = lambda name, default: self.declare_parameter(name, default).value
        self.frame_id = value("frame_id", "tissue")
        self.session = palpate.Session(value("scene", "block"), device=value("device", "touch"))
        self.site_m = self.session.site_m
        self.due_ns = None
        self.told = None
        self.unturned = None
        for caution in self.session.cautions:
            self.get_logger().warning(caution)
        self.wrenches = self.create_publisher(WrenchStamped, "wrench", 1)
        # the newest pose only, from drivers of either reliability
        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.poses = self.create_subscription(PoseStamped, "tip", self.tick, newest)
        self.services_ = [
            self.create_service(Trigger, name, lambda request, response, ask=ask: self.asked(ask, response))
            for name, ask in [("arm", self.session.arm), ("stop", self.session.stop), ("clear", self.session.clear)]
        ]

    def late_ticks(self, stamp):
        """Ticks that are missing before the one of this stamp; a driver may run a little faster than 1 kHz."""
        now_ns = stamp.sec * 1_000_000_000 + stamp.nanosec
        due_ns = now_ns if self.due_ns is None else min(self.due_ns + TICK_NS, now_ns)
        late = (now_ns - due_ns) // TICK_NS
        self.due_ns = due_ns + late * TICK_NS
        return min(late, 1000)

    def turn(self, q):
        try:
            self.session.turn((q.x, q.y, q.z, q.w))
        except palpate.PalpateError as error:
            if str(error) != self.unturned:
                self.get_logger().warning(str(error))
            self.unturned = str(error)

    def tick(self, pose):
        p = pose.pose.position
        self.turn(pose.pose.orientation)
        force_n = self.session.tick(
            self.site_m + (p.x, p.y, p.z),
            late_ticks=self.late_ticks(pose.header.stamp),
            sensor_failed=pose.header.frame_id != self.frame_id,
        )
        message = WrenchStamped()
        message.header.stamp = pose.header.stamp
        message.header.frame_id = self.frame_id
        for vector, numbers in [(message.wrench.force, force_n), (message.wrench.torque, torque_nm(self.session, force_n))]:
            vector.x, vector.y, vector.z = (float(number) for number in numbers)
        self.wrenches.publish(message)
        fault = self.session.fault
        if fault and fault != self.told:
            self.get_logger().error(fault)
        self.told = fault

    def asked(self, ask, response):
        try:
            ask()
            response.success = True
        except palpate.PalpateError as error:
            response.message = str(error)
        return response


def main():
    rclpy.init()
    node = TissueNode()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
