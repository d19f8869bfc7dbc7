"""Task and pipeline files: YAML fragments become typed documents, with every error at its file, line and column.

Read `task_file` for the task, `predicate_reader` for its conditions. Nothing here imports a simulator, USD or a
renderer.
"""
