"""The project file: clicks, history, references, runs and settings of a recording.

One SQLite file beside the recording, opened by :class:`project.Project`. Everything that a person
does is an :class:`edit.Edit`: a frozen value that is applied, kept in the history in the same
transaction, and undone by writing the rows that stood there before. ``apply`` returns when the
edit is on the drive. What programs compute stands in tables of its own::

    with Project.create(project_path_for(folder), folder, who="A") as project:
        project.on_change(lambda changed: print(changed.words, changed.frames()))
        project.apply(place(Click(213, "N_right", "left_elbow", (311.5, 240.25))))
        project.clicks.at(213)
        project.undo()

Edits are in ``clicks``, ``marks``, ``entries``, ``selection``, ``setups``, ``runs`` and
``merging``; several become one by :class:`edit.Together`.
"""
