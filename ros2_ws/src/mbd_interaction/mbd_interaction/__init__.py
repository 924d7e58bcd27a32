"""The dialogue with teacher and wizard: phases, prompts, assists, undo."""
