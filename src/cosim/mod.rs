//! Co-simulation: the same vectors through every simulator, compared bit for bit.
