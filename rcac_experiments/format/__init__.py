"""A file format from declarations: reader, error messages, JSON Schema and documentation."""
