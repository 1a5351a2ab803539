"""Two places and a time: every motion that joins them (Greenwood (1977), §5-1; Lambert's problem for any system)."""
