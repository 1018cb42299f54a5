"""The report on a budget: from results to the blocks of a document."""
