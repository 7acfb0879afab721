"""The contact laws of pymdr as models of nanite."""

from pymdr_nanite.models import MODELS, register, register_tip

__all__ = ["MODELS", "register", "register_tip"]
