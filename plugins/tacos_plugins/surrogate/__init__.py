"""A model of the scores of a study, quick enough to be asked for every camera there is."""
