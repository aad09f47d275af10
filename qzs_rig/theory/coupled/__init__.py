"""The coupled platform balanced in six coordinates."""
