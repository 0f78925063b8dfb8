"""Translation of user input (case files, Python arguments) to a Case."""
