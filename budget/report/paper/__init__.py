"""The paper beside ours: terminal text, JSON, CSV, and a document of blocks."""
