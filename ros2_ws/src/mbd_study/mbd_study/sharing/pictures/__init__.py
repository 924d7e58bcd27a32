"""Pictures and clouds of a copy for others: covered are what is not of the table, and the faces that are found."""
