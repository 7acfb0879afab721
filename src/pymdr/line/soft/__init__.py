"""Adhesion of bodies with memory: Dugdale's zone on springs that creep."""
