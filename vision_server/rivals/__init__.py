"""What the project is compared with: other merge rules, linking and splitting, the genetic matcher."""
