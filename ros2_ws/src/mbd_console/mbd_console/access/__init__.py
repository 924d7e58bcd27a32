"""Who may open the console, and what a browser may do with its pages."""
