"""The service: the database over HTTP, for programs in any language, and for the page at /.

Read in this order: limits and refusals (what may be asked, and how it is told that something may
not), catalogue (the databases), work (places, threads, ends), questions, fillanswers, holeanswers,
surfaces, patternpages, jobs (what is answered, knowing nothing of HTTP), answers and guard (how
HTTP carries it, and what every request passes), metrics, context (what routes share), the routes in
looking, asking, learning and page, and application, which puts it together.

    from patterndb_app.service.application import make_application
"""
