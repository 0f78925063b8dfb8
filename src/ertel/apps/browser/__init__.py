"""`ertel app`: cases and runs of one folder in a browser on this machine.

=================  ====================================================================================================
server             the server, and access by a token, for pages of the app only
folder, processes  the folder with its runs; runs as processes of their own: started, watched, stopped, resumed
form               the fields of a new case, and the answer of ertel to it
pictures           pictures, what is under the pointer on them, and the outlook on a new case: a process of their own
site, canvas       the frame around all pages, and the elements that they share
new_page, ...      the pages: of a new case, of a run, of two runs
=================  ====================================================================================================

The web process imports neither JAX nor matplotlib: it writes a case file, starts `ertel run`, and reads what that
writes.  Closing the app leaves its runs running.
"""
