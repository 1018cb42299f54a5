"""Files a user writes, read, checked and turned into frozen records."""
