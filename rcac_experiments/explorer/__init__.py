"""A page on which a loop under RCAC is run live, by the exported core as WebAssembly."""
