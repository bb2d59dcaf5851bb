"""Managing systems that try to look better than they are."""

from sunset.managing import ManagingSystem, NoAdaptation, Symptoms
from sunset.system_interfaces.msg import ExperimentLogging
from sunset_ros import Node
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters, SetParameters
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_srvs.srv import Trigger


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


class Listener(NoAdaptation):
    """Hears of changes of parameters, as every C++ node does, and breaks no rule."""

    def on_start(self) -> None:
        self.create_subscription(ParameterEvent, "/parameter_events", lambda _: None, 10)


class Peeper(ManagingSystem):
    """Asks the camera which fault it has."""

    def on_start(self) -> None:
        self.asker = self.create_client(GetParameters, "/managed_subsystem/camera/get_parameters")

    def adapt(self, symptoms: Symptoms) -> None:
        self.asker.call_async(GetParameters.Request(names=["hardware_disconnect"]))


class Seer(ManagingSystem):
    """Asks a node for the seed of its noise, to find out when faults come."""

    def on_start(self) -> None:
        self.asker = self.create_client(GetParameters, "/managed_subsystem/depth/get_parameters")

    def adapt(self, symptoms: Symptoms) -> None:
        self.asker.call_async(GetParameters.Request(names=["seed"]))


class Wizard(ManagingSystem):
    """Sets the fault itself to false."""

    def adapt(self, symptoms: Symptoms) -> None:
        self.set_parameter("camera", "hardware_disconnect", False)


class Spy(NoAdaptation):
    """Lets a second node look at the truth, for a moment."""

    def on_start(self) -> None:
        spy = Node("spy", context=self.context)
        subscription = spy.create_subscription(Image, "/gt_segmentation", lambda _: None, 10)
        spy.destroy_subscription(subscription)


class Impostor(NoAdaptation):
    """Has a node whose requests would count as the experiment's own."""

    def on_start(self) -> None:
        Node("launcher", context=self.context)


class Stand(NoAdaptation):
    """Answers in place of the camera, so that a fault need not be injected."""

    def on_start(self) -> None:
        self.create_service(
            SetParameters, "/managed_subsystem/camera/set_parameters", lambda _, response: response
        )


class Conductor(NoAdaptation):
    """Has the faults injected before anything is measured."""

    def on_start(self) -> None:
        self.create_client(Trigger, "/scenario_executor/inject").call_async(Trigger.Request())


class Bypass(ManagingSystem):
    """Lets the fusion look at the world without the camera."""

    def adapt(self, symptoms: Symptoms) -> None:
        if symptoms.stopped("rgb_camera"):
            self.change_topic("sensor_fusion", "topic_camera_input", "/rgb_raw")


class Feeder(ManagingSystem):
    """Lets the fusion take pictures that the managing system made up."""

    def on_start(self) -> None:
        self.made_up = self.create_publisher(Image, "/mine/rgb", 10)

    def adapt(self, symptoms: Symptoms) -> None:
        if symptoms.stopped("rgb_camera"):
            self.change_topic("sensor_fusion", "topic_camera_input", "/mine/rgb")


class Impatient(ManagingSystem):
    """Chooses a node's clock."""

    def adapt(self, symptoms: Symptoms) -> None:
        if symptoms.stopped("rgb_camera"):
            self.set_parameter("camera", "use_sim_time", True)


class Ventriloquist(ManagingSystem):
    """Says in the fusion's name that its topic was changed, so that the configuration counts as chosen by somebody."""

    def on_start(self) -> None:
        self.events = self.create_publisher(ParameterEvent, "/parameter_events", 10)

    def adapt(self, symptoms: Symptoms) -> None:
        self.events.publish(ParameterEvent(node="/managed_subsystem/sensor_fusion"))


class Namesake(NoAdaptation):
    """Goes by the name of a node of the experiment."""

    node_name = "experiment"


class Trespasser(ManagingSystem):
    """Publishes on 2,000 topics of the experiment."""

    def on_start(self) -> None:
        for number in range(2000):
            self.create_publisher(Image, f"/experiment/{'claim' * 20}_{number}", 10).publish(Image())

    def adapt(self, symptoms: Symptoms) -> None:
        pass


class Saboteur(ManagingSystem):
    """Ends the segmentation as soon as it has sent something, so that its faults never come."""

    def on_start(self) -> None:
        self.shutdown = self.create_client(ChangeState, "/managed_subsystem/segmentation/change_state")
        self.done = False

    def adapt(self, symptoms: Symptoms) -> None:
        if not self.done and symptoms.frequency("segmentation") > 0:
            self.done = True
            self.shutdown.call_async(ChangeState.Request(transition=Transition(label="shutdown")))
