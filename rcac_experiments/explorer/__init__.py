"""The explorer: an interactive page that runs an RCAC loop by the exported core as WebAssembly."""
