//! Shapes written as OBJ files.
