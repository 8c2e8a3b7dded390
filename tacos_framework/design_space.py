"""The design space: which camera parameters vary, and between what.

A :class:`DesignSpace` is seen from two sides. The recipe and the report speak of *variables*
(``sensor = IMX178``); optimizers speak of *genes*, a flat vector of numbers in natural units. `decode` snaps
genes to what can be manufactured, so an optimizer may propose anything.

Catalog variables follow the two schemes of the paper (Sec. 3.3): ``discrete``, one gene that counts catalog
rows, and ``quantized``, one gene per numeric column and the nearest row afterwards (eq. 2).
"""
