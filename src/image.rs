//! Images: encoding and files.
