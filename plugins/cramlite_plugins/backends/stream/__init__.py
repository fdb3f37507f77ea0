"""Programs streamed as actions at a fixed rate to a process that speaks JSON lines."""
