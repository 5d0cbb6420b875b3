"""Quality of a calibration: prediction, cross-validation, model selection, assessment, report."""
