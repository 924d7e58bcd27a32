"""The page that sets paper and project side by side."""
