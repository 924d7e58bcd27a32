"""The page of the demonstrated steps, on which the teacher corrects them."""
