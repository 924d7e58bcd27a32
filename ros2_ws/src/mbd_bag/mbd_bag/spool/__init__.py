"""What a session says, kept beside its bag: nothing of it is lost while the recorder is away."""
