"""The cell as other robots' and cameras' drivers speak: their names, types, rates and quirks."""
