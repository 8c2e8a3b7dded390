"""Design variables: what each may be, and how it looks to an optimizer.

Every variable turns the numbers of an optimizer into a value that can be manufactured, and back. Constructors
refuse what makes no sense with a `ValueError` that says so in a sentence.
"""

from __future__ import annotations

from tacos_framework.variables.catalog_choice import CatalogChoice
from tacos_framework.variables.categorical import Categorical
from tacos_framework.variables.gene import Gene, Variable
from tacos_framework.variables.numeric import Continuous, Integer

__all__ = ["CatalogChoice", "Categorical", "Continuous", "Gene", "Integer", "Variable"]
