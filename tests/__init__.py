"""Tests, in folders that mirror the source tree; `support` has what several of them use."""
