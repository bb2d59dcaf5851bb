"""Nodes with a lifecycle, as in `rclpy.lifecycle`."""

from sunset_ros.lifecycle._state_machine import TRANSITIONS as TRANSITIONS
from sunset_ros.lifecycle._state_machine import LifecycleState as LifecycleState
from sunset_ros.lifecycle._state_machine import TransitionCallbackReturn as TransitionCallbackReturn
from sunset_ros.lifecycle.managed_entity import ManagedEntity as ManagedEntity
from sunset_ros.lifecycle.managed_entity import SimpleManagedEntity as SimpleManagedEntity
from sunset_ros.lifecycle.node import LifecycleNode as LifecycleNode
from sunset_ros.lifecycle.publisher import LifecyclePublisher as LifecyclePublisher

Node = LifecycleNode
State = LifecycleState
Publisher = LifecyclePublisher
