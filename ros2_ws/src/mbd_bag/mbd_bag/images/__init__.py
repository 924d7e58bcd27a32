"""Images in a bag: compressed, and written without rclpy."""
