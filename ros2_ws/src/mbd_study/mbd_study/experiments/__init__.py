"""The paper's data as session bags, its experiments 2 and 3, and the page that sets paper and project side by side."""
