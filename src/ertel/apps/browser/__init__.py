"""`ertel app`: cases and runs of one folder in a browser on this machine.

====================  =================================================================================================
command, guard        the command; access by a token, for pages of the app only
folder, records       the folder and its runs; case and summary of a run, also of one that cannot be read
processes             runs as processes of their own: started, watched, stopped, resumed
form, checking        what a user fills in, and what ertel says of it
pictures, drawing     pictures, drawn by a process of their own; wishes: what it is asked and answers
site, canvas, words   what all pages share
... _page             one file for each page; answer: the right side of that of a new case
====================  =================================================================================================

The web process imports neither JAX nor matplotlib: it writes a case file, starts `ertel run`, and reads what that
writes.  Closing the app leaves its runs running.
"""
