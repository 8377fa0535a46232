"""Classification of configurations and motions: free, near, colliding."""
