"""What tests share: small worlds, programs and recordings, and checks of theirs."""
