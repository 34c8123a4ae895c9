"""The wire types, made by protoc from proto/hapticd/v1/*.proto when the project is built."""
