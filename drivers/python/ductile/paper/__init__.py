"""The study of Patel & Stark, Soft Matter 17, 4804 (2021), and how ours compares: doc/paper.md."""
