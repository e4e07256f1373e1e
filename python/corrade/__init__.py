"""A drop-in for `corrade`, which `import habitat` imports and navigation does not use: it has no names."""
