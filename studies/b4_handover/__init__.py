"""From the report to the machine: six laws handed over, and what a computer costs each of them."""
