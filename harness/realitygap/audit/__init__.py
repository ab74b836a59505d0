"""The audit: a certificate that all engines run the same machine, judged by Pinocchio and by closed forms."""

from realitygap.audit.audit import audit, certify
from realitygap.audit.certificate import Certificate, Proof

__all__ = ["Certificate", "Proof", "audit", "certify"]
