"""What is intact in a damaged sqlite3 file of rosbag2, read from its pages: sqlite itself refuses such a file."""
