"""The ROS graph: nodes, topics, services, parameters and lifecycles. ROS thread only."""
