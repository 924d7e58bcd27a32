"""The bytes of a bag's files, whoever wrote them: read within bounds, also when they are damaged or hostile."""
