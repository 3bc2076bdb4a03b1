"""Read, patch and build glTF 2.0 documents."""
