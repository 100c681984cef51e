import rclpy
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class ResetClient(Node):
    def __init__(self):
        super().__init__("reset_client")
        self.client = self.create_client(ResetEncoder, "reset_encoder")
        while not self.client.wait_for_service(timeout_sec=1.0):
            self.get_logger().info("Waiting for reset_encoder ...")
        self.request = ResetEncoder.Request()

    def send_request(self):
        return self.client.call_async(self.request)


def main(args=None):
    rclpy.init(args=args)
    node = ResetClient()
    future = node.send_request()
    rclpy.spin_until_future_complete(node, future)
    response = future.result()
    node.get_logger().info(f"Result: {response.success}, {response.message}")
    node.destroy_node()
    rclpy.shutdown()
    return response


if __name__ == "__main__":
    main()
