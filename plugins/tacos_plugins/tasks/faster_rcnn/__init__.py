"""The task `task.faster-rcnn`: an object detector, trained and scored."""
