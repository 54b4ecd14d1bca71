"""Reports of verifications and of studies, and the pages of many of them."""
