"""What experiments came to: logs, tables, differences, figures, where numbers come from, and the paper's own."""
