"""Plants that are no arm: published plants under published laws."""
