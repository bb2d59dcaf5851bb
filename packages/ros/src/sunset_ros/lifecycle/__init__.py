"""Nodes with a lifecycle, as in `rclpy.lifecycle`."""

from sunset_ros.lifecycle._state_machine import TRANSITIONS as TRANSITIONS
from sunset_ros.lifecycle._state_machine import LifecycleState as LifecycleState
from sunset_ros.lifecycle._state_machine import TransitionCallbackReturn as TransitionCallbackReturn
from sunset_ros.lifecycle.managed_entity import LifecyclePublisher as LifecyclePublisher
from sunset_ros.lifecycle.managed_entity import ManagedEntity as ManagedEntity
from sunset_ros.lifecycle.managed_entity import SimpleManagedEntity as SimpleManagedEntity
from sunset_ros.lifecycle.node import LifecycleNode as LifecycleNode

Node = LifecycleNode
State = LifecycleState
Publisher = LifecyclePublisher
