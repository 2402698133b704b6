"""What deploy/wheel is made of: libraries are found, licences collected, the result is checked and packed."""
