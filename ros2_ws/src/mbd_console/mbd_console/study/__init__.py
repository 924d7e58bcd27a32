"""What a study needs beside the dialogue: forms, markers, checklists, a countdown."""
