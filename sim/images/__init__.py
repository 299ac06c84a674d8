"""Images apart from the running cell: generated test images, and rendered pictures to train networks on."""
