import rclpy
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient
from rclpy.node import Node


class Sender(Node):
    def __init__(self):
        super().__init__("sender")
        self.client = ActionClient(self, MoveToShelf, "move_to_shelf")

    def send(self, shelf):
        self.client.wait_for_server()
        return self.client.send_goal_async(MoveToShelf.Goal(shelf_number=shelf))


def main():
    rclpy.init()
    sender = Sender()
    future = sender.send(3)
    rclpy.spin_until_future_complete(sender, future)


if __name__ == "__main__":
    main()
