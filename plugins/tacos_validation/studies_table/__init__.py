"""The procedure `procedure.studies-table`: studies of one problem in one table, published figures beside."""
