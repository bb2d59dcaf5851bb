"""Managing systems that try to look better than they are."""

from sunset.interfaces.rcl_interfaces.srv import GetParameters
from sunset.interfaces.sensor_msgs.msg import Image
from sunset.interfaces.system_interfaces.msg import ExperimentLogging
from sunset.managing import ManagingSystem, NoAdaptation, Symptoms


class Claimer(ManagingSystem):
    """Does nothing, and says on its own topic that it resolved everything."""

    def on_start(self) -> None:
        self.claims = self.create_publisher(ExperimentLogging, "/experiment_setup/bt_executor_log", 10)

    def adapt(self, symptoms: Symptoms) -> None:
        now = self.get_clock().now().nanoseconds
        for source in ("analyzer", "planning", "execute"):
            self.claims.publish(
                ExperimentLogging(
                    timestamp=now, source=source, rule_name="redeploy_camera", success=True, iou=1.0
                )
            )


class Forger(ManagingSystem):
    """Publishes a segmentation of its own."""

    def on_start(self) -> None:
        self.fake = self.create_publisher(Image, "/managed_subsystem/segmentation", 10)

    def adapt(self, symptoms: Symptoms) -> None:
        self.fake.publish(Image(height=1, width=1, encoding="8UC1", step=1, data=[0]))


class Eavesdropper(NoAdaptation):
    """Subscribes to the truth."""

    def on_start(self) -> None:
        self.create_subscription(Image, "/gt_segmentation", lambda _: None, 10)


class Peeper(ManagingSystem):
    """Asks the camera which fault it has."""

    def on_start(self) -> None:
        self.asker = self.create_client(GetParameters, "/managed_subsystem/camera/get_parameters")

    def adapt(self, symptoms: Symptoms) -> None:
        self.asker.call_async(GetParameters.Request(names=["hardware_disconnect"]))


class Wizard(ManagingSystem):
    """Sets the fault itself to false."""

    def adapt(self, symptoms: Symptoms) -> None:
        self.set_parameter("camera", "hardware_disconnect", False)
