"""Nodes with a lifecycle, as in `rclpy.lifecycle`."""

from sunset_ros.lifecycle._state_machine import TRANSITIONS, LifecycleState, TransitionCallbackReturn
from sunset_ros.lifecycle.managed_entity import ManagedEntity, SimpleManagedEntity
from sunset_ros.lifecycle.node import LifecycleNode
from sunset_ros.lifecycle.publisher import LifecyclePublisher

Node = LifecycleNode
State = LifecycleState
Publisher = LifecyclePublisher

__all__ = [
    "TRANSITIONS",
    "LifecycleNode",
    "LifecyclePublisher",
    "LifecycleState",
    "ManagedEntity",
    "Node",
    "Publisher",
    "SimpleManagedEntity",
    "State",
    "TransitionCallbackReturn",
]
