"""Scene compiler: turns a scene program (YAML) into a complete, checked scene, a proof that there is none, or a report
of an exhausted step budget. `compile.compile_program` runs all phases in order; `session.Session` does so edit after
edit.
"""
