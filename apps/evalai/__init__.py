"""What EvalAI's workers import: the archive is unpacked into a package, whose evaluate() they call."""

from .main import evaluate

__all__ = ["evaluate"]
